"""Maps between systems: motions to motions in another time, or tori to tori."""
