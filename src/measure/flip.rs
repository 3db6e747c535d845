//! FLIP: how different two pictures look when one flips between them.
