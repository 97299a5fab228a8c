"""The named clips: targets, and how contractions are found for them."""
