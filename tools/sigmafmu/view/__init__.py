"""A mechanism in motion: one HTML file that a browser shows, or glTF that other programs open."""
