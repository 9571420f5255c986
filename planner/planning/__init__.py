"""Choice and timing of what is pointed at: windows, sessions, campaigns."""
