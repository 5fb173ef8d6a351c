!> A row of a table: its fields, with a comma between each two.
module taut_case_row
   use taut_case_number, only: number_length, number_printer_t
   use taut_error, only: to_text
   use taut_kinds, only: wp
   implicit none (type, external)
   private
   public :: row_t

   !> A row that is filled, written and filled anew in the same place.
   type :: row_t
      !> The letters, of which the first `used` are set.
      character(:), allocatable :: letters
      !> Letters of the row so far.
      integer :: used = 0
      type(number_printer_t), private :: printer
   contains
      generic :: add => add_number, add_integer, add_text
      procedure :: create
      procedure :: clear
      procedure, private :: add_number, add_integer, add_text
   end type row_t

contains

   !> Makes an empty row.
   subroutine create(self)
      !> The row.
      class(row_t), intent(inout) :: self

      if (.not. allocated(self%letters)) allocate (character(len=4096) :: self%letters)
      call self%printer%prepare()
      self%used = 0
   end subroutine create

   !> Begins anew.
   subroutine clear(self)
      !> The row.
      class(row_t), intent(inout) :: self

      self%used = 0
   end subroutine clear

   !> Appends a number in full precision.
   subroutine add_number(self, value)
      !> The row.
      class(row_t), intent(inout) :: self
      !> The number.
      real(wp), intent(in) :: value
      integer :: length

      call begin_field(self, number_length)
      call self%printer%put(value, self%letters(self%used + 1:self%used + number_length), length)
      self%used = self%used + length
   end subroutine add_number

   !> Appends an integer.
   subroutine add_integer(self, value)
      !> The row.
      class(row_t), intent(inout) :: self
      !> The number.
      integer, intent(in) :: value

      call self%add(to_text(value))
   end subroutine add_integer

   !> Appends a text as it is: `csv_field` makes it fit for a table.
   subroutine add_text(self, text)
      !> The row.
      class(row_t), intent(inout) :: self
      !> The text.
      character(*), intent(in) :: text

      call begin_field(self, len(text))
      self%letters(self%used + 1:self%used + len(text)) = text
      self%used = self%used + len(text)
   end subroutine add_text

   !> Sets the comma before a field that is not the first, and makes room for so many letters.
   subroutine begin_field(self, length)
      type(row_t), intent(inout) :: self
      integer, intent(in) :: length
      character(:), allocatable :: longer

      if (self%used + length + 1 > len(self%letters)) then
         allocate (character(len=2*(self%used + length + 1)) :: longer)
         longer(1:self%used) = self%letters(1:self%used)
         call move_alloc(longer, self%letters)
      end if
      if (self%used == 0) return
      self%used = self%used + 1
      self%letters(self%used:self%used) = ','
   end subroutine begin_field

end module taut_case_row
