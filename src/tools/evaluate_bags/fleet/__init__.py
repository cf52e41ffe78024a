"""Parts of evaluate_bags."""
