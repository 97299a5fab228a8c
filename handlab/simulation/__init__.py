"""State and time: kinematics, skeleton, skin, key frames, and the clips they give."""
