"""What is read off members, so that their states need not be kept."""
