"""Built-in scenes, one TOML file each; a file's name without ending is the scene's name."""
