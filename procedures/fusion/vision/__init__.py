"""What a camera saw: features followed, relative rotation and structure, its delay."""
