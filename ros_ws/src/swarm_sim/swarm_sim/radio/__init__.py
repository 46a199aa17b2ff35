"""The radio medium: outboxes -> inboxes."""
