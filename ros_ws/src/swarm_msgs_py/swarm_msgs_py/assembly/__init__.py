"""Assembly of docking boats: the vocabulary that mission computer, boats and world share."""
