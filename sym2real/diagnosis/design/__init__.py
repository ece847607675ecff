"""What a manoeuvre would show before it is flown, and which one distinguishes alternative effects."""
