"""Human-like room segmentation of topo-metric maps (§2) and its experiments (§3)."""
