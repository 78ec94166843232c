"""The demo: the whole main job on a simulated device, its truth beside what was found."""
