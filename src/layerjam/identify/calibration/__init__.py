"""From pulls to the numbers of a brake, with intervals and a verdict."""
