!> What is said of a run: why it failed, what happened on the way, what an entry is called.
submodule(taut_constrained_method) taut_constrained_method_words
   use taut_constrained_first_look, only: first_look
   use taut_constrained_system_tables, only: coordinate_name, velocity_name
   implicit none (type, external)

   !> So many changes of the rank are told one by one.
   integer, parameter :: most_changes = 3

contains

   !> Why the last evaluation or projection failed.
   module procedure failure

      call self%blows%explain(text)
      if (len(text) == 0) call self%mass%explain(self%model, text)
      if (len(text) == 0) call self%reactions%explain(text)
      if (len(text) == 0) call self%projector%explain(self%model, text)
      if (len(text) == 0) call self%own_failure(text)
   end procedure failure

   !> Compares derivatives with differences at a state where steps do not get on.
   module procedure find_fault
      type(error_t), allocatable :: error

      fault = ''
      looked = self%model%c > 0
      if (.not. looked) return
      call self%unpack(t, y, self%at)
      call first_look(self%model, self%at, error)
      if (allocated(error)) fault = error%what
   end procedure find_fault

   !> What is to be said of the motion so far that is no error: drives that begin or stop at once strike blows.
   module procedure remark
      character(:), allocatable :: row
      integer :: i
      character(:), allocatable :: own

      call self%blows%remark(text)
      associate (changes => self%projector%linear%keeper%changes)
         do i = 1, size(changes, 2)
            if (len(text) > 0) text = text//'; '
            if (i > most_changes) then
               text = text//'the rank changes '//to_text(size(changes, 2) - most_changes)//' times more'
               exit
            end if
            call self%model%row_name(nint(changes(4, i)), row)
            text = text//'at t = '//to_text(changes(1, i))//' s the rank '// &
                   trim(merge('rises', 'falls', changes(3, i) > changes(2, i)))//' from '//to_text(nint(changes(2, i)))//' to '// &
                   to_text(nint(changes(3, i)))//': '//row
         end do
      end associate
      call self%own_remark(own)
      if (len(text) > 0 .and. len(own) > 0) text = text//'; '
      text = text//own
      call self%projector%orientation%remark(own)
      if (len(text) > 0 .and. len(own) > 0) text = text//'; '
      text = text//own
   end procedure remark

   !> What an entry of the last derivative is: of an acceleration, the force if that is not a number already.
   module procedure entry_name
      real(wp) :: force(self%model%n)
      integer :: i

      i = entry - self%model%n_x
      if (i > 0 .and. i <= self%model%n) then
         call self%model%force(self%at, force)
         if (.not. all(ieee_is_finite(force))) then
            i = findloc(ieee_is_finite(force), .false., 1)
            text = 'the force on '//trim(velocity_name(self%model, i))
         else
            text = 'the acceleration of '//trim(velocity_name(self%model, i))
         end if
      else if (i <= 0) then
         text = 'the rate of '//trim(coordinate_name(self%model, entry))
      else
         text = 'the rate of w('//to_text(i - self%model%n)//')'
      end if
   end procedure entry_name

end submodule taut_constrained_method_words
