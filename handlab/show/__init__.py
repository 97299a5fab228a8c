"""The only place that draws, and that writes pictures and films. Drawing libraries load when something is drawn."""
