"""Four machines with layer-jamming brakes (paper, section III-F and Fig. 13)."""
