"""Comparison of images: visible differences (FLIP), PSNR and statistics of tiles."""
