"""Node-on-segment contact for contactlab."""
