"""Cases with known answers for contact algorithms, one file each."""
