"""What happens: procedures run on a brake, and the records they give."""
