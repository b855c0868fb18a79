"""What is watched along a run, and how its drift is judged."""
