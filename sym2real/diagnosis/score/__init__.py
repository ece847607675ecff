"""What was found, on data that took no part in its fit: ladder, gate, values with intervals."""
