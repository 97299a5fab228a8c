"""A photograph becomes a hand: landmarks, calibration, alignment, warp, retargeting."""
