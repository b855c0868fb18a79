"""Volumes of tangent boxes carried along by a step: the drift of an invariant measure."""
