"""The spine: frozen records that every stage speaks. Arrays and records, no disk, no clock."""
