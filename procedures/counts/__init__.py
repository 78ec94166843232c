"""From recorded counts to rates with an honest sigma, and whether counts can be true."""
