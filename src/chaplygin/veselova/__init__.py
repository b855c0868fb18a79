"""The Veselova problem: bodies whose angular velocity is bound in space."""
