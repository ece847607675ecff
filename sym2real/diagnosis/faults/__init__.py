"""What is wrong with logs before a model is blamed: units, signs, orders, frames, sensors."""
