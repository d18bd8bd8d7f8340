"""Runs on a timeline: recordings for the rerun viewer."""
