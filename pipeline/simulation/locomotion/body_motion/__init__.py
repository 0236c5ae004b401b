"""What creatures do beside their legs: heads, tails, feelers, trunks."""
