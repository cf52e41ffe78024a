"""The modules of evaluate_bags."""
