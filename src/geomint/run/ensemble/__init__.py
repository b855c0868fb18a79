"""Many runs at once: in lanes, on cores, on the workers of an executor."""
