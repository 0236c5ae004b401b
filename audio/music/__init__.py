"""Music: bars, songs and generated pieces as notes on beats."""
