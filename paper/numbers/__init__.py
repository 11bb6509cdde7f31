"""The numbers that the text quotes, by what they tell of."""
