"""The numbers that the text quotes, by subject; each function declares what it reads."""
