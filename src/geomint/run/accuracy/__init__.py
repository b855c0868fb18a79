"""Steps chosen by the accuracy that is wanted at the end."""
