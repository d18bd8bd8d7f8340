"""Studies: every combination of some choices, run side by side and measured: accuracy against cost."""
