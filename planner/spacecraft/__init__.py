"""An agile spacecraft with control moment gyros that images the Earth: plan, table, judge."""
