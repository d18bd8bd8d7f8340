"""The model: bodies, contacts, loading and state of a scene, built once and bound to arrays."""
