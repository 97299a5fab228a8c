"""The two ways to wear the skin between which a viewer chooses by itself: light, because every command imports it."""

BLEND, SOFT = "blend", "springs and muscles"
