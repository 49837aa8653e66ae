"""From the bodies of a case to walls and particles: outlines, meshes, distances, filling, checks. numpy only."""
