"""Questions asked of a hand."""
