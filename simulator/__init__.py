"""The 2D cleaning-robot simulator: from an apartment to a topo-metric map (§2.1)."""
