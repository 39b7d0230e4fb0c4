"""Numbers printed in four papers, side by side with the true ones."""
