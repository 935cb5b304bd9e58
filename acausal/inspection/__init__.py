"""What a person gets to see of the stages of the compiler."""
