"""How far the model lies from measured pulls."""
