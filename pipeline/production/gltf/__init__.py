"""Binary glTF: takes for viewers and other programs."""
