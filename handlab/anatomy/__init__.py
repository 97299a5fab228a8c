"""Facts that never change: terms and signs, tables, the hand as frozen records."""
