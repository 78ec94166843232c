"""What is known about cubes, slabs and IMUs, and every calibration ever accepted."""
