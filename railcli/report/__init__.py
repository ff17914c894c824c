"""What people read: tables of text and figures. Units for readers (mm, mrad, kN) are made here."""
