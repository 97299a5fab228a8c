"""Colours. Where a colour means something it is one of Okabe and Ito's eight, and a line style, marker or word says it too."""

from __future__ import annotations

BLACK, ORANGE, SKY, GREEN = "#000000", "#E69F00", "#56B4E9", "#009E73"
YELLOW, BLUE, VERMILION, PURPLE = "#F0E442", "#0072B2", "#D55E00", "#CC79A7"

# In an order in which neighbours differ most; yellow last, it is weak on white.
OKABE_ITO = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY, BLACK, YELLOW)
LINES = ("-", "--", "-.", ":", (0, (6, 1, 1, 1, 1, 1)), (0, (1, 2)), (0, (8, 3)), (0, (3, 1, 1, 1)))
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "*")

PAPER = "#FFFFFF"
SKY_OF_STILLS = "#E3E8ED"
INK = "#1F2933"
FAINT = "#6B7785"
RULE = "#D5DBE1"

SKIN = (226, 184, 162)
SKIN_PALM = (236, 198, 179)
SKIN_DEEP = (203, 128, 112)
SKIN_PALE = (241, 212, 195)
NAIL = (243, 205, 197)
IVORY = "#EFE4CB"
