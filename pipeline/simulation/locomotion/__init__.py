"""Walking, hopping, jumping and crawling creatures (Sims 1987, ch. 9 to 12)."""
