"""The exact flow on invariant tori: states at any time without stepping. See `flow`."""
