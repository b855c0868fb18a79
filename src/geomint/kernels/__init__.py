"""What runs compiled: numbers, blocks, steppers, group actions. Imports nothing above itself."""
