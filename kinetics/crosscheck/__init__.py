"""The court: holds the three witnesses against each other and writes the reports."""
