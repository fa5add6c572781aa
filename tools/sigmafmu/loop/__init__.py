"""Controllers in the loop: laws, closed loops of a mechanism and its controller, and the same as SSP systems."""
