"""Parts: how plugins are loaded, checked against the contract, and made from what a scene writes."""
