"""The live hand in a browser: trame serves our own viewer on this computer; VTK is imported only when a film is exported."""
